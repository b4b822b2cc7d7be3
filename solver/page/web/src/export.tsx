import "./export.css";
